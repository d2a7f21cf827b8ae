"""Xacro expanded to plain URDF: its elements, its scopes, its files; nothing runs and nothing swells."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree.ElementTree import Element, tostring

import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.files.model_files import PackageResolver
from tactile_maps.robots.files.safe_files import parse_model_xml
from tactile_maps.robots.formats.xacro import process_xacro

Expand = Callable[..., Element]


@pytest.fixture
def expand(tmp_path: Path) -> Expand:
    """Return a function that expands the content of a <robot> in a folder with the given files."""

    def run(content: str, **files: str) -> Element:
        (tmp_path / "package.xml").write_text("<package><name>kit</name></package>")
        (tmp_path / "urdf").mkdir(exist_ok=True)
        for name, text in files.items():
            stem, _, ending = name.rpartition("_")
            (tmp_path / "urdf" / f"{stem}.{ending}").write_text(text)
        path = tmp_path / "urdf" / "main.xacro"
        path.write_text(robot(content))
        root = parse_model_xml(path.read_bytes(), file=path)
        result = process_xacro(root, path, PackageResolver(path))
        assert not any("xacro" in element.tag for element in result.iter())
        return result

    return run


def robot(content: str) -> str:
    return f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{content}</robot>'


def flat(root: Element) -> str:
    return "".join(tostring(child, encoding="unicode").strip() for child in root)


def test_properties_are_numbers_or_texts_and_evaluated_when_used(expand):
    content = (
        '<xacro:property name="twice" value="${2 * width}"/><xacro:property name="width" value="0.2"/>'
        '<xacro:property name="side" value="left"/><xacro:property name="number" value="\'7\'"/>'
        '<link name="${side}_link" a="${twice}" b="${width + 1} x" c="${number}" d="$${side}" e="${sin(pi / 2)}"/>'
    )
    link = expand(content)[0]
    assert link.attrib == {"name": "left_link", "a": "0.4", "b": "1.2 x", "c": "7", "d": "${side}", "e": "1.0"}


def test_macros_have_parameters_defaults_values_of_the_caller_and_blocks(expand):
    content = (
        '<xacro:property name="mass" value="3"/>'
        '<xacro:macro name="part" params="name side:=left mass:=^ other:=^|9 scale:=\'1 2\' *origin **inside">'
        '<link name="${side}_${name}" mass="${mass}" other="${other}" scale="${scale}">'
        '<xacro:insert_block name="origin"/><xacro:insert_block name="inside"/></link></xacro:macro>'
        '<xacro:part name="arm" side="right"><origin xyz="${mass} 0 0"/><any><box/><ball/></any></xacro:part>'
        '<xacro:part name="leg" other="5"><origin/><any/></xacro:part>'
    )
    assert flat(expand(content)) == (
        '<link name="right_arm" mass="3" other="9" scale="1 2"><origin xyz="3 0 0" /><box /><ball /></link>'
        '<link name="left_leg" mass="3" other="5" scale="1 2"><origin /></link>'
    )


def test_macro_may_call_itself_until_a_condition_ends_it(expand):
    content = (
        '<xacro:macro name="row" params="n"><link name="l${n}"/>'
        '<xacro:if value="${n > 0}"><xacro:row n="${n - 1}"/></xacro:if>'
        '<xacro:unless value="${n > 0}"><end/></xacro:unless></xacro:macro><xacro:row n="3"/>'
    )
    assert [child.get("name") for child in expand(content)] == ["l3", "l2", "l1", "l0", None]


def test_arguments_have_their_defaults_and_a_missing_one_is_named(expand):
    content = (
        '<xacro:arg name="tip" default="hand"/>'
        "<xacro:if value=\"${'$(arg tip)' == 'hand'}\"><a b=\"$(arg tip)\"/></xacro:if>"
    )
    assert flat(expand(content)) == '<a b="hand" />'
    with pytest.raises(RobotError, match=r"no default.*found: side.*side:="):
        expand('<xacro:arg name="side"/><link name="$(arg side)"/>')


def test_files_are_included_by_path_and_by_package(expand):
    macros = robot('<xacro:macro name="part" params="name"><link name="${name}"/></xacro:macro>')
    pytest.importorskip("yaml")
    content = (
        '<xacro:include filename="macros.xacro"/><xacro:include filename="$(find kit)/urdf/more.xacro" ns="more"/>'
        '<xacro:property name="limits" value="${xacro.load_yaml(\'limits.yaml\')}"/>'
        '<xacro:part name="${more.word}"/><xacro:more.part name="b"/>'
        '<x a="${limits[\'hip\'].upper}" b="${limits.hip.lower}"/>'
        '<m filename="$(find kit)/meshes/a.stl"/>'
    )
    more = robot(
        '<xacro:property name="word" value="hello"/>'
        '<xacro:macro name="part" params="name"><b name="${name}"/></xacro:macro>'
    )
    settings = "hip: {upper: 1.5, lower: !degrees -180}\n"
    found = expand(content, macros_xacro=macros, more_xacro=more, limits_yaml=settings)
    assert flat(found) == (
        '<link name="hello" /><b name="b" /><x a="1.5" b="-3.141592653589793" />'
        '<m filename="package://kit/meshes/a.stl" />'
    )


def test_property_may_be_a_block_change_and_be_global(expand):
    content = (
        '<xacro:property name="block"><a/><b c="${n}"/></xacro:property><xacro:property name="n" value="1"/>'
        '<xacro:macro name="count"><xacro:property name="n" value="${n + 1}" scope="global"/></xacro:macro>'
        '<xacro:count/><xacro:insert_block name="block"/><xacro:property name="n" default="9"/><d e="${n}"/>'
    )
    assert flat(expand(content)) == '<a /><b c="2" /><d e="2" />'


def test_elements_attributes_and_calls_may_be_named_by_expressions(expand):
    content = (
        '<xacro:macro name="part"><a/></xacro:macro><xacro:property name="which" value="part"/>'
        '<xacro:call macro="${which}"/><xacro:element xacro:name="${which}_x">'
        '<xacro:attribute name="n" value="${1 + 1}"/></xacro:element>'
    )
    assert flat(expand(content)) == '<a /><part_x n="2" />'


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("<xacro:nobody/>", "unknown macro"),
        ('<xacro:macro name="m" params="a"/><xacro:m/>', "lacks a parameter"),
        ('<xacro:macro name="m" params="*a"/><xacro:m/>', "lacks a block"),
        ('<xacro:insert_block name="b"/>', "unknown block"),
        ('<xacro:if value="perhaps"/>', "neither true nor false"),
        ('<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/><x y="${a}"/>', "by itself"),
        ('<x y="${absent}"/>', "absent is not defined"),
        ('<x y="$(env HOME)"/>', "not supported"),
        ('<xacro:include filename="absent.xacro"/>', "no such file"),
        ('<xacro:include filename="$(find absent)/a.xacro"/>', "package is not found"),
        ('<xacro:include filename="/etc/passwd"/>', "leaves the robot"),
        ('<xacro:include filename="../../../secret.xacro"/>', "leaves the robot"),
        ('<xacro:include filename="../id_rsa"/>', "only models and meshes"),
        ('<xacro:include filename="main.xacro"/>', "files are included|nested too deep"),
        ("<x y=\"${load_yaml('/etc/passwd')}\"/>", "leaves the robot"),
        ('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>', "nested too deep"),
        (
            '<xacro:property name="a" value="xxxxxxxxxxxxxxxx"/>'
            + "".join(
                f'<xacro:property name="{chr(98 + i)}" value="${{{chr(97 + i)}}}${{{chr(97 + i)}}}"/>'
                for i in range(20)
            )
            + '<x y="${u}"/>',
            "too long",
        ),
        pytest.param(
            "".join(f'<xacro:macro name="m{i}"><xacro:m{i + 1}/><xacro:m{i + 1}/></xacro:macro>' for i in range(30))
            + '<xacro:macro name="m30"/><xacro:m0/>',
            "more than 200000 elements",
            marks=pytest.mark.long,
        ),
    ],
)
def test_invalid_unsafe_or_endless_content_is_rejected(expand, content, words):
    with pytest.raises(RobotError, match=words) as found:
        expand(content)
    assert "main.xacro" in str(found.value) or "absent.xacro" in str(found.value)
