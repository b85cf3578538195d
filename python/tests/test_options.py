"""Options of commands are derived from the functions that they call."""

import argparse
import importlib
import inspect
from typing import Any

import pytest
from dth_hammer.cli import main
from dth_hammer.commands import COMMANDS
from dth_hammer.commands.options import Call, kind
from dth_hammer.figures import settled_cycle
from dth_hammer.figures.page import report
from dth_hammer.scene.scene import Scene

#: Commands with hand-written options, because their functions need a package that may be missing.
BY_HAND: dict[str, tuple[Any, dict[str, str]]] = {
    "demo": (
        settled_cycle,
        {
            "preset": "the hammer is one",
            "rock": "the demo is the hammer's own",
            "until": "long enough that the blows repeat",
            "outlook": "what the figure shows",
            "fine": "what the figure shows",
        },
    ),
    "report": (report, {"preset": "the hammer is one", "curve": "read from --sn"}),
}


def calls(name: str) -> list[Call]:
    module = importlib.import_module(f"dth_hammer.commands.{name}")
    return [value for value in vars(module).values() if isinstance(value, Call)]


def options(name: str, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit, match="0"):
        main([name, "--help"])
    return capsys.readouterr().out


@pytest.mark.parametrize("name", COMMANDS)
def test_every_argument_of_a_function_is_an_option_or_there_is_a_reason(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    said = options(name, capsys).split()
    for call in calls(name):
        assert {*call.written} | {*call.without} == {*inspect.signature(call.function).parameters}
        assert all(call.without.values())
        for argument, written in call.written.items():
            assert {*written.flags} & {word.rstrip(",") for word in said}, argument
    for function, without in [BY_HAND[name]] if name in BY_HAND else []:
        for argument in inspect.signature(function).parameters:
            assert argument in without or {f"--{argument}", argument} & {*said}, argument
    assert calls(name) or name in BY_HAND


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_is_described_and_its_default_is_that_of_the_function(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    parser = argparse.ArgumentParser()
    for call in calls(name):
        call.declare(parser)
        defaults = {n: p.default for n, p in inspect.signature(call.function).parameters.items()}
        # An option that is not given is not passed on, so the function's own default applies.
        parser.set_defaults(**{action.dest: None for action in parser._actions if action.required})
        for action in parser._actions:
            action.required = False
        given = call.given(parser.parse_args([]))
        for argument, value in given.items():
            if argument in ("hammer", "base"):
                assert value == Scene()
                continue
            own = defaults[argument]
            assert value in (own, {}) or argument in ("progress", "goal", "until"), argument
    for action in parser._actions:
        assert action.help, action.dest
        assert not {"``", "None", " if None"} & {action.help}, action.dest


def test_an_argument_that_no_function_takes_is_refused() -> None:
    with pytest.raises(TypeError, match="settled_cycle does not take colour"):
        Call(settled_cycle, {"colour": "there is none"})


def test_annotations_say_how_an_option_is_read() -> None:
    assert kind("error", float, 0.1)["type"]("5 %") == 0.05
    assert kind("seed", int | None, None) == {"type": int}
    assert kind("until", float | str | None, 0.6) == {}
    assert kind("least", bool, False) == {"action": "store_true"}
    assert kind("simulated", bool, True) == {"action": "store_false"}
    assert kind("outputs", list[str], ())["type"](" rop, ,kind") == ["rop", "kind"]
