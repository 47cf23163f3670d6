"""The Python that the manual shows: what it calls is there, and takes what it is given."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import stickslip

DOCS = Path(__file__).parents[3] / "docs"
# The commands that are functions too, by their pages.
PAGES = {
    "check": ["check"],
    "calibrate": ["calibrate"],
    "compare": ["compare"],
    "diagnose": ["diagnose"],
    "add": ["add", "refit"],
    "suggest": ["suggest"],
    "replay": ["replay"],
    "score": ["score"],
    "simulate": ["simulate"],
    "import-recordings": ["Dataset.from_recording", "check"],
}


def calls(page: str) -> list[tuple[str, ast.Call]]:
    """What a page's Python calls of the package: its name, and the call."""
    found = []
    for code in re.findall(r"```python\n(.*?)```", (DOCS / f"{page}.md").read_text(), re.DOTALL):
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func)
                if name.startswith("stickslip.") and "(" not in name:
                    found.append((name.removeprefix("stickslip."), node))
    return found


@pytest.mark.parametrize("page", PAGES)
def test_a_page_of_a_command_shows_its_function_with_arguments_that_it_takes(page: str) -> None:
    found = calls(page)
    assert {name for name, _ in found} == set(PAGES[page])
    for name, call in found:
        function = stickslip
        for part in name.split("."):
            function = getattr(function, part)
        keywords = {word.arg: None for word in call.keywords if word.arg}
        inspect.signature(function).bind(*[None] * len(call.args), **keywords)


@pytest.mark.parametrize("page", PAGES)
def test_effects_that_a_page_names_exist(page: str) -> None:
    for name, call in calls(page):
        if name in ("add", "suggest"):
            given = [*call.args[1:2]] if name == "add" else [w.value for w in call.keywords if w.arg == "between"]
            assert set(ast.literal_eval(given[0])) <= set(stickslip.effect_names())
