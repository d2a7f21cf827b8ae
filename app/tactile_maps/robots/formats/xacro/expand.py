"""Expansion of xacro elements to a plain tree: properties, arguments, macros, blocks, conditions and includes.

As in xacro since 2016, elements are processed in order, scopes are those of the call, and a property is evaluated when
it is used.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.files.model_files import PACKAGE_ROOT_OPTION, PackageResolver
from tactile_maps.robots.files.plain_yaml import parse_yaml
from tactile_maps.robots.files.safe_files import MAX_ELEMENTS, parse_xml, read_bytes
from tactile_maps.robots.formats.xacro.expressions import Budget, ExpressionError, evaluate

_MAX_INCLUDES = 100
_MAX_CALLS_DEEP = 60
_BY_HAND = "Run xacro on it and open the URDF it writes"
_TAG = re.compile(r"\{[^}]*xacro[^}]*\}(.+)")
_PARTS = re.compile(r"(\$\$+(?=[{(]))|\$\{([^}]*)\}|\$\(([^)]*)\)")
_PARAMETER = re.compile(r"""\s*(\*{0,2}[^\s:=*]+)(?:\s*:?=\s*(\^\|?)?((?:'[^']*'|"[^"]*"|\$\{[^}]*\}|[^\s'"])*))?""")


def has_xacro(root: Element) -> bool:
    """Whether an element or attribute below ``root`` belongs to xacro, or a value contains an expression."""
    return any(
        ("}" in name and "xacro" in name) or value.startswith(("$(optenv", "$(arg", "${"))
        for element in root.iter()
        for name, value in ((element.tag, ""), *element.attrib.items())
    )


def process_xacro(root: Element, file: Path, packages: PackageResolver) -> Element:
    """Return the plain tree of ``root``; arguments have their default values.

    Args:
        root: Parsed tree of the file; it is not changed.
        file: The file, for relative names and errors.
        packages: Finds included files.

    Raises:
        RobotError: An expression, macro, argument or file is invalid, missing or not supported; it names the element.
    """
    expansion = _Expansion(file, packages)
    result = Element(root.tag)
    scope = _Scope()
    result.attrib.update(expansion.attributes(root, scope, file))
    expansion.expand_into(result, root, scope, file)
    return result


@dataclass(frozen=True, eq=False)
class _Macro:
    parameters: tuple[tuple[str, str, str | None], ...]
    """Name, ``^`` if the caller's value has priority, and default."""
    body: Element
    file: Path


@dataclass(frozen=True, eq=False)
class _Raw:
    """Text of a property, evaluated when it is used, in the scope in which it was written."""

    text: str
    scope: _Scope
    file: Path


class _Scope:
    """Names in one scope. Mutable."""

    def __init__(self, parent: _Scope | None = None) -> None:
        self.parent = parent
        self.values: dict[str, Any] = {}
        self.blocks: dict[str, list[Element]] = {}
        self.macros: dict[str, _Macro] = {}

    def chain(self) -> Iterator[_Scope]:
        scope: _Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent


class _Expansion:
    """An expansion of a file. Mutable: counts the created elements and stores the arguments."""

    def __init__(self, main: Path, packages: PackageResolver) -> None:
        self._main = main
        self._packages = packages
        self._arguments: dict[str, Any] = {}
        self._made = self._included = self._deep = 0
        self._open: list[_Raw] = []
        self._budget = Budget()
        self._special: dict[str, Callable[[Element, Element, _Scope, Path], None]] = {
            "property": self._property,
            "arg": self._argument,
            "macro": self._macro,
            "include": self._include,
            "if": self._condition,
            "unless": self._condition,
            "insert_block": self._insert,
            "call": self._dynamic_call,
            "element": self._element,
            "attribute": self._attribute,
        }

    def expand_into(self, target: Element, source: Element, scope: _Scope, file: Path) -> None:
        """Append the expanded children of ``source`` to ``target``."""
        text = (source.text or "").strip()
        if text:
            target.text = (target.text or "") + str(self.text(text, scope, file))
        for child in source:
            self._made += 1
            if self._made > MAX_ELEMENTS:
                raise RobotError(f"the macros create more than {MAX_ELEMENTS} elements", file=self._main)
            found = _TAG.fullmatch(child.tag)
            if found is None:
                made = Element(child.tag, self.attributes(child, scope, file))
                target.append(made)
                self._in_scope(made, child, scope, file)
            elif found[1] in self._special:
                self._special[found[1]](target, child, scope, file)
            else:
                self._call(found[1], target, child, scope, file)

    def _in_scope(self, target: Element, source: Element, scope: _Scope, file: Path) -> None:
        """Expand one level deeper; the depth is limited because of Python's stack."""
        self._deep += 1
        if self._deep > 3 * _MAX_CALLS_DEEP:
            raise RobotError("elements or macros are nested too deep", file=file, value=source.tag, remedy=_BY_HAND)
        self.expand_into(target, source, scope, file)
        self._deep -= 1

    def attributes(self, element: Element, scope: _Scope, file: Path) -> dict[str, str]:
        """Return the evaluated attributes of an element, without those of xacro."""
        return {
            name: str(self.text(value, scope, file)) for name, value in element.attrib.items() if "xacro}" not in name
        }

    def text(self, text: str, scope: _Scope, file: Path) -> Any:
        """Return the value of a text with ``${...}`` and ``$(...)``: a number or list if it is a single expression."""
        parts = list[Any]()
        end = 0
        for found in _PARTS.finditer(text):
            if found.start() > end:
                parts.append(text[end : found.start()])
            parts.append(self._part(found, scope, file))
            end = found.end()
        if end < len(text):
            parts.append(text[end:])
        try:
            return parts[0] if len(parts) == 1 else self._budget.checked("".join(map(str, parts)))
        except ExpressionError as error:
            raise RobotError(f"a text cannot be evaluated: {error}", file=file, value=text, remedy=_BY_HAND) from error

    def _part(self, found: re.Match[str], scope: _Scope, file: Path) -> Any:
        if found[1] is not None:
            return found[1][1:]
        if found[2] is None:
            return self._substitution(found[3].split(), scope, file)
        expression = str(self.text(found[2], scope, file))
        try:
            return evaluate(expression, lambda name: self._value(name, scope), self._functions(file), self._budget)
        except ExpressionError as error:
            problem = f"an expression cannot be evaluated: {error}"
            raise RobotError(problem, file=file, value=found[0], remedy=_BY_HAND) from error

    def _functions(self, file: Path) -> dict[str, Callable[..., Any]]:
        return {
            "load_yaml": lambda name: self._settings(str(name), file),
            "arg": lambda name: self._argument_of(name, file),
            "dotify": lambda value: value,
        }

    def _value(self, name: str, scope: _Scope) -> Any:
        for place in scope.chain():
            if name in place.values:
                value = place.values[name]
                if isinstance(value, _Raw):
                    value = place.values[name] = self._evaluated(value, name)
                return value
        raise KeyError(name)

    def _evaluated(self, raw: _Raw, name: str) -> Any:
        if raw in self._open:
            raise RobotError("a property is defined by itself", file=raw.file, place=name, value=raw.text)
        if len(self._open) > _MAX_CALLS_DEEP:
            raise RobotError("properties are nested too deep", file=raw.file, place=name, value=raw.text)
        self._open.append(raw)
        value = _literal(self.text(raw.text, raw.scope, raw.file))
        self._open.pop()
        return value

    def _substitution(self, words: list[str], scope: _Scope, file: Path) -> Any:
        """Return the value of ``$(find package)``, ``$(arg name)`` and similar; the environment is not accessible."""
        match words:
            case ["find" | "find-pkg-share", name]:
                return f"package://{name}"
            case ["arg", name]:
                return self._argument_of(str(self.text(name, scope, file)), file)
            case ["optenv", _, *default]:
                return " ".join(default)
            case ["dirname" | "cwd"]:
                return str(file.resolve().parent)
            case ["eval", *rest]:
                return self.text("${" + " ".join(rest) + "}", scope, file)
        raise RobotError("this is not supported", file=file, value=f"$({' '.join(words)})", remedy=_BY_HAND)

    def _argument_of(self, name: str, file: Path) -> Any:
        if name not in self._arguments:
            remedy = f"Run xacro on it with {name}:=..., and open the URDF it writes"
            raise RobotError("an argument has no default", file=file, place="xacro:arg", value=name, remedy=remedy)
        return self._arguments[name]

    # Elements.

    def _property(self, _target: Element, element: Element, scope: _Scope, file: Path) -> None:
        name = self._named(element, scope, file)
        text = element.get("value", element.get("default"))
        known = any(name in place.values for place in scope.chain())
        if element.get("default") is not None and element.get("value") is None and known:
            return
        chain = list(scope.chain())
        place = {"parent": chain[min(1, len(chain) - 1)], "global": chain[-1]}.get(element.get("scope", ""), scope)
        if element.get("remove", "").lower() in ("true", "1"):
            place.values.pop(name, None)
        elif text is None:
            place.blocks[name] = [deepcopy(child) for child in element]
        elif place is scope and not _refers_to(name, text):
            place.values[name] = _Raw(text, scope, file)
        else:
            place.values[name] = _literal(self.text(text, scope, file))

    def _argument(self, _target: Element, element: Element, scope: _Scope, file: Path) -> None:
        name = self._named(element, scope, file)
        if name not in self._arguments and element.get("default") is not None:
            self._arguments[name] = str(self.text(element.get("default", ""), scope, file))

    def _macro(self, _target: Element, element: Element, scope: _Scope, file: Path) -> None:
        name = self._named(element, scope, file).removeprefix("xacro:")
        found = [_PARAMETER.match(part) for part in _split_parameters(element.get("params", ""))]
        parameters = tuple((one[1], one[2] or "", one[3]) for one in found if one is not None)
        scope.macros[name] = _Macro(parameters, element, file)

    def _include(self, target: Element, element: Element, scope: _Scope, file: Path) -> None:
        self._included += 1
        if self._included > _MAX_INCLUDES:
            remedy = "Look for files that include each other"
            raise RobotError(f"more than {_MAX_INCLUDES} files are included", file=self._main, remedy=remedy)
        address = str(self.text(element.get("filename", ""), scope, file))
        path = self._resolve(address, file)
        if not os.path.isfile(path) and element.get("optional", "").lower() in ("true", "1"):
            return
        root = parse_xml(read_bytes(path), file=path)
        if root.tag != "robot" and not _TAG.fullmatch(root.tag):
            raise RobotError("the included file is not URDF", file=file, value=address)
        inner = _Scope(scope) if element.get("ns") else scope
        self._in_scope(target, root, inner, path)
        if element.get("ns"):
            self._keep_namespace(str(element.get("ns")), inner, scope)

    def _keep_namespace(self, name: str, inner: _Scope, scope: _Scope) -> None:
        scope.values[name] = {key: self._value(key, inner) for key in list(inner.values)}
        scope.macros |= {f"{name}.{key}": macro for key, macro in inner.macros.items()}

    def _condition(self, target: Element, element: Element, scope: _Scope, file: Path) -> None:
        value = self.text(element.get("value", ""), scope, file)
        if _truth(value, file) == element.tag.endswith("}if"):
            self._in_scope(target, element, scope, file)

    def _insert(self, target: Element, element: Element, scope: _Scope, file: Path) -> None:
        name = self._named(element, scope, file)
        block = next((place.blocks[name] for place in scope.chain() if name in place.blocks), None)
        if block is None:
            raise RobotError("unknown block", file=file, place="xacro:insert_block", value=name)
        holder = Element("block")
        holder[:] = block
        self._in_scope(target, holder, scope, file)

    def _element(self, target: Element, element: Element, scope: _Scope, file: Path) -> None:
        """Create an element whose name is an expression."""
        named = next((value for key, value in element.attrib.items() if key.endswith("xacro}name")), "")
        made = Element(str(self.text(named, scope, file)), self.attributes(element, scope, file))
        target.append(made)
        self._in_scope(made, element, scope, file)

    def _attribute(self, target: Element, element: Element, scope: _Scope, file: Path) -> None:
        """Set an attribute of the parent element."""
        target.set(self._named(element, scope, file), str(self.text(element.get("value", ""), scope, file)))

    def _dynamic_call(self, target: Element, element: Element, scope: _Scope, file: Path) -> None:
        named = next((key for key in element.attrib if key.split("}")[-1] == "macro"), "")
        call = Element(element.tag, {key: value for key, value in element.attrib.items() if key != named})
        call[:] = list(element)
        self._call(str(self.text(element.get(named, ""), scope, file)), target, call, scope, file)

    def _call(self, name: str, target: Element, element: Element, scope: _Scope, file: Path) -> None:
        macro = next((place.macros[name] for place in scope.chain() if name in place.macros), None)
        if macro is None:
            raise RobotError("unknown macro", file=file, value=f"xacro:{name}", remedy=_BY_HAND)
        given = dict(element.attrib)
        expanded = Element("blocks")
        self._in_scope(expanded, element, scope, file)
        blocks = iter(expanded)
        inner = _Scope(scope)
        for parameter, forward, default in macro.parameters:
            plain = parameter.lstrip("*")
            if parameter.startswith("*"):
                block = next(blocks, None)
                if block is None:
                    raise RobotError("a macro lacks a block", file=file, place=f"xacro:{name}", value=plain)
                inner.blocks[plain] = list(block) if parameter.startswith("**") else [block]
            elif plain in given:
                inner.values[plain] = _literal(self.text(given[plain], scope, file))
            elif (
                forward
                and (known := next((p.values[plain] for p in scope.chain() if plain in p.values), None)) is not None
            ):
                inner.values[plain] = known
            elif default is None or (forward == "^" and not default):
                raise RobotError("a macro lacks a parameter", file=file, place=f"xacro:{name}", value=plain)
            else:
                inner.values[plain] = _literal(self.text(_unquoted(default), inner, macro.file))
        self._in_scope(target, macro.body, inner, macro.file)

    def _named(self, element: Element, scope: _Scope, file: Path) -> str:
        name = str(self.text(element.get("name", ""), scope, file))
        if not name:
            raise RobotError("a xacro element has no name", file=file, value=element.tag.split("}")[-1])
        return name

    # Files.

    def _settings(self, name: str, file: Path) -> Any:
        path = self._resolve(name, file)
        return parse_yaml(read_bytes(path), path)

    def _resolve(self, address: str, file: Path) -> Path:
        """Return the path of a file that is named relative to another one."""
        if address.startswith("package://") and self._packages.package(address[10:].partition("/")[0]) is None:
            remedy = f"Give the folder that holds the package as a package root ({PACKAGE_ROOT_OPTION})"
            raise RobotError("the package is not found", file=file, value=address, remedy=remedy)
        if "://" not in address:
            address = str(file.resolve().parent / address)
        return self._packages.resolve(address)


def _literal(value: Any) -> Any:
    """Return a text as number or truth value if it is one; otherwise without quotes around it."""
    if not isinstance(value, str):
        return value
    if len(value) >= 2 and value[0] == value[-1] == "'":
        return value[1:-1]
    if "_" in value:
        return value
    for kind in (int, float):
        try:
            return kind(value)
        except ValueError:
            continue
    return {"true": True, "True": True, "false": False, "False": False}.get(value, value)


def _truth(value: Any, file: Path) -> bool:
    value = _literal(value)
    if isinstance(value, str):
        raise RobotError("a condition is neither true nor false", file=file, value=value)
    return bool(value)


def _refers_to(name: str, text: str) -> bool:
    """Whether the new value of a property refers to its old one."""
    return "$" in text and re.search(rf"\b{re.escape(name)}\b", text) is not None


def _split_parameters(text: str) -> list[str]:
    return [found[0] for found in _PARAMETER.finditer(text)]


def _unquoted(text: str) -> str:
    return text[1:-1] if len(text) >= 2 and text[0] == text[-1] and text[0] in "'\"" else text
