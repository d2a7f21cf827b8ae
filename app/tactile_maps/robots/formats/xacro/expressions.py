"""Expressions between ``${`` and ``}`` in xacro: arithmetic, comparisons, lists, and a fixed set of functions.

Python parses an expression; its nodes are evaluated here, and only those that are listed. Numbers, texts and lists are
limited, so that no short expression takes long.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

MAX_LENGTH = 20_000
"""Largest length of an expression, and of texts and lists that it creates."""
_MAX_POWER = 1000.0
_MAX_WHOLE = 1 << 128
_MAX_DEPTH = 60

Lookup = Callable[[str], Any]
Functions = Mapping[str, Callable[..., Any]]

_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Not: operator.not_,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
    ast.Is: operator.eq,
    ast.IsNot: operator.ne,
}
_CONSTANTS = {"pi": math.pi, "e": math.e, "tau": math.tau, "inf": math.inf, "nan": math.nan}
_NAMED: dict[str, Any] = {**_CONSTANTS, "true": True, "false": False, "none": None}
_MATHS = (
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "sqrt",
    "exp",
    "log",
    "log10",
    "radians",
    "degrees",
    "hypot",
    "fabs",
    "floor",
    "ceil",
    "fmod",
    "isnan",
    "isinf",
    "copysign",
    "trunc",
)
_FUNCTIONS: dict[str, Callable[..., Any]] = {name: getattr(math, name) for name in _MATHS} | {
    "abs": abs,
    "min": min,
    "max": max,
    "round": round,
    "len": len,
    "int": int,
    "float": float,
    "bool": bool,
    "str": str,
    "list": list,
    "tuple": tuple,
    "dict": dict,
    "sum": sum,
    "sorted": sorted,
    "all": all,
    "any": any,
    "range": lambda *ends: _short_range(*ends),
    "pow": lambda a, b: _power(a, b),
    "tokenize": lambda text, *_: str(text).replace(",", " ").replace(";", " ").split(),
}
_NAMESPACES = ("math", "python", "xacro")
_METHODS: dict[type, frozenset[str]] = {
    str: frozenset(("lower", "upper", "strip", "startswith", "endswith", "split", "replace", "find", "count")),
    dict: frozenset(("get", "keys", "values", "items")),
    list: frozenset(("index", "count")),
}


class ExpressionError(ValueError):
    """An expression that is invalid or not supported."""


class Budget:
    """Limit of the cost of all expressions of one file. Mutable.

    Args:
        steps: Number of evaluated nodes and of parts of their results.
    """

    def __init__(self, steps: int = 1_000_000) -> None:
        self._left = steps

    def spend(self, steps: int) -> None:
        """Subtract ``steps``; raises ExpressionError if the limit is exceeded."""
        self._left -= steps
        if self._left < 0:
            raise ExpressionError("the file's expressions take too long")

    def checked(self, value: Any) -> Any:
        """Return ``value`` if it is not too large; its parts count."""
        if isinstance(value, int) and abs(value) > _MAX_WHOLE:
            raise ExpressionError("a number is too large")
        if isinstance(value, str | list | tuple | dict):
            size = _size(value)
            if size > MAX_LENGTH:
                raise ExpressionError("a text or list is too long")
            self.spend(size // 16)
        return value


def evaluate(text: str, lookup: Lookup, functions: Functions, budget: Budget | None = None) -> Any:
    """Return the value of an expression.

    Args:
        text: Untrusted text.
        lookup: Returns the value of a property; raises KeyError.
        functions: Additional functions by name, such as ``load_yaml``.
        budget: Budget of the whole file.

    Raises:
        ExpressionError: The text is not a supported expression, or its value is too large.
    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError("the expression is too long")
    try:
        tree = ast.parse(text.strip(), mode="eval")
        return _Evaluator(lookup, {**_FUNCTIONS, **functions}, budget or Budget()).value(tree.body, 0)
    except ExpressionError:
        raise
    except KeyError as error:
        raise ExpressionError(f"{error.args[0]} is not defined") from error
    except (
        SyntaxError,
        TypeError,
        ValueError,
        ArithmeticError,
        IndexError,
        AttributeError,
        MemoryError,
        RecursionError,
    ) as error:
        raise ExpressionError(str(error)) from error


class _Evaluator:
    """Evaluates one expression."""

    def __init__(self, lookup: Lookup, functions: Functions, budget: Budget) -> None:
        self._lookup = lookup
        self._functions = functions
        self._budget = budget

    def value(self, node: ast.AST, depth: int) -> Any:
        if depth > _MAX_DEPTH:
            raise ExpressionError("it is nested too deep")
        self._budget.spend(1)
        return self._budget.checked(self._value(node, depth + 1))

    def _value(self, node: ast.AST, depth: int) -> Any:
        match node:
            case ast.Constant(value=constant):
                return constant
            case ast.Name(id=name):
                return self._named(name)
            case ast.UnaryOp(op=op, operand=operand):
                return _OPERATORS[type(op)](self.value(operand, depth))
            case ast.BinOp(left=left, op=op, right=right):
                return _binary(op, self.value(left, depth), self.value(right, depth))
            case ast.BoolOp():
                return self._any_or_all(node, depth)
            case ast.Compare():
                return self._compare(node, depth)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self.value(body if self.value(test, depth) else orelse, depth)
            case ast.List(elts=parts):
                return [self.value(part, depth) for part in parts]
            case ast.Tuple(elts=parts):
                return tuple(self.value(part, depth) for part in parts)
            case ast.Dict(keys=keys, values=values):
                found = [self.value(key, depth) for key in keys if key is not None]
                return dict(zip(found, (self.value(part, depth) for part in values), strict=True))
            case ast.Slice(lower=lower, upper=upper, step=step):
                return slice(*(None if end is None else self.value(end, depth) for end in (lower, upper, step)))
            case ast.Subscript(value=owner, slice=index):
                return self.value(owner, depth)[self.value(index, depth)]
            case ast.Attribute():
                return self._attribute(node, depth)
            case ast.Call(keywords=[_, *_]):
                raise ExpressionError("named arguments are not supported")
            case ast.Call(func=called, args=parts):
                function = self._called(called, depth)
                return function(*(self.value(part, depth) for part in parts))
        raise ExpressionError(f"{type(node).__name__} is not supported")

    def _named(self, name: str) -> Any:
        try:
            return self._lookup(name)
        except KeyError:
            if name in _NAMED:
                return _NAMED[name]
            raise

    def _any_or_all(self, node: ast.BoolOp, depth: int) -> Any:
        result = None
        stop = isinstance(node.op, ast.Or)
        for part in node.values:
            result = self.value(part, depth)
            if bool(result) == stop:
                break
        return result

    def _compare(self, node: ast.Compare, depth: int) -> bool:
        left = self.value(node.left, depth)
        for test, part in zip(node.ops, node.comparators, strict=True):
            right = self.value(part, depth)
            if not _OPERATORS[type(test)](left, right):
                return False
            left = right
        return True

    def _attribute(self, node: ast.Attribute, depth: int) -> Any:
        """Return the value of a key of a dictionary, or a constant of a namespace."""
        if isinstance(node.value, ast.Name) and node.value.id in _NAMESPACES and node.attr in _CONSTANTS:
            return _CONSTANTS[node.attr]
        owner = self.value(node.value, depth)
        if not isinstance(owner, dict):
            raise ExpressionError(f"{node.attr} is not supported")
        return owner[node.attr]

    def _called(self, node: ast.AST, depth: int) -> Callable[..., Any]:
        if isinstance(node, ast.Name):
            return self._function(node.id)
        if not isinstance(node, ast.Attribute):
            raise ExpressionError("only functions can be called")
        if isinstance(node.value, ast.Name) and node.value.id in _NAMESPACES:
            return self._function(node.attr)
        owner = self.value(node.value, depth)
        if node.attr not in _METHODS.get(type(owner), ()):
            raise ExpressionError(f"{node.attr} is not supported")
        if node.attr == "replace":
            return lambda old, new: _replaced(owner, old, new)
        method: Callable[..., Any] = getattr(owner, node.attr)
        return (lambda: list(method())) if node.attr in ("keys", "values", "items") else method

    def _function(self, name: str) -> Callable[..., Any]:
        if name not in self._functions:
            raise ExpressionError(f"unknown function {name}")
        return self._functions[name]


def _binary(operation: ast.operator, left: Any, right: Any) -> Any:
    if isinstance(operation, ast.Pow):
        return _power(left, right)
    if isinstance(operation, ast.Mod) and isinstance(left, str):
        raise ExpressionError("texts are not formatted with %")
    if isinstance(operation, ast.Mult):
        _check_copies(left, right)
    return _OPERATORS[type(operation)](left, right)


def _size(value: Any) -> int:
    """Return the number of characters and parts of ``value``, including nested parts; stops above ``MAX_LENGTH``."""
    size = 0
    todo = [value]
    while todo and size <= MAX_LENGTH:
        part = todo.pop()
        size += len(part) if isinstance(part, str) else 1
        if isinstance(part, list | tuple):
            todo.extend(part)
        elif isinstance(part, dict):
            todo.extend([*part.keys(), *part.values()])
    return size


def _power(base: Any, exponent: Any) -> Any:
    if isinstance(exponent, int | float) and abs(exponent) > _MAX_POWER:
        raise ExpressionError("an exponent is too large")
    return base**exponent


def _check_copies(left: Any, right: Any) -> None:
    for several, times in ((left, right), (right, left)):
        if isinstance(several, str | list | tuple) and isinstance(times, int) and len(several) * times > MAX_LENGTH:
            raise ExpressionError("a text or list is too long")


def _replaced(text: str, old: Any, new: Any) -> str:
    if text.count(str(old)) * len(str(new)) > MAX_LENGTH:
        raise ExpressionError("a text or list is too long")
    return text.replace(str(old), str(new))


def _short_range(*ends: int) -> list[int]:
    found = range(*ends)
    if len(found) > MAX_LENGTH:
        raise ExpressionError("a text or list is too long")
    return list(found)
