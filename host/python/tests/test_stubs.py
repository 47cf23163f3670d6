"""The stubs of the native part say what it has: mypy checks everything above against them, and nothing against it."""

import ast
import inspect
from pathlib import Path

import stickslip
from stickslip import _stickslip

STUBS = ast.parse(Path(stickslip.__file__).with_name("_stickslip.pyi").read_text())


def stated(body: list[ast.stmt]) -> dict[str, ast.stmt]:
    """Classes, functions and constants by name."""
    found: dict[str, ast.stmt] = {}
    for node in body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            found[node.name] = node
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            found[node.target.id] = node
    return found


def public(names: object) -> set[str]:
    """Without what every module and class has."""
    own = {"__version__"}
    return {name for name in names if name in own or not name.startswith("_")}


def parameters(node: ast.FunctionDef) -> list[str]:
    """Names of a stub's parameters, without self."""
    of = node.args
    names = [a.arg for a in (*of.posonlyargs, *of.args, *of.kwonlyargs)]
    return names[1:] if names[:1] == ["self"] else names


def same_parameters(node: ast.FunctionDef, native: object, where: str) -> None:
    signature = [name for name in inspect.signature(native).parameters if name != "self"]
    assert signature == parameters(node), where


def test_the_stubs_name_what_the_native_module_has_and_nothing_else():
    top = stated(STUBS.body)
    assert public(top) == public(vars(_stickslip))
    classes = functions = 0
    for name, node in top.items():
        native = getattr(_stickslip, name, None)
        if isinstance(node, ast.FunctionDef):
            same_parameters(node, native, name)
            functions += 1
        elif isinstance(node, ast.ClassDef) and not issubclass(native, Exception):
            members = stated(node.body)
            assert public(members) == public(vars(native)), name
            for method, of in members.items():
                is_property = any(isinstance(d, ast.Name) and d.id == "property" for d in of.decorator_list)
                assert is_property != callable(getattr(native, method)), f"{name}.{method}"
                if not is_property:
                    same_parameters(of, getattr(native, method), f"{name}.{method}")
            classes += 1
    assert classes >= 2 and functions >= 5
