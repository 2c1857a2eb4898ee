"""The optional board in logic: what it needs is named. What it does is tested in the folder rtl."""

import pytest

from repro.board import logic
from repro.errors import InputError


@pytest.mark.parametrize("load", [logic.logic_board, logic.board_size])
def test_missing_extra_is_named(monkeypatch, load):
    monkeypatch.setattr("repro.errors.find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"'\.\[rtl\]'"):
        load()


def test_missing_compiler_and_installation_without_checkout_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr(logic, "require", lambda *_: None)
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(InputError, match="no-such-compiler"):
        logic.logic_board()
    monkeypatch.setenv("CXX", "true")
    monkeypatch.setattr(logic, "_CHECKOUT", tmp_path)
    with pytest.raises(InputError, match=str(tmp_path)):
        logic.logic_board()
