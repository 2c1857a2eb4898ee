"""The optional board in logic: what it needs is named. What it does is tested in the folder rtl."""

import pytest

from repro.errors import InputError
from repro.fpga import logic


def test_missing_compiler_is_named(monkeypatch):
    monkeypatch.setattr(logic, "require", lambda *_: None)
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(InputError) as error:
        logic.logic_board()
    assert "no-such-compiler" in str(error.value)


@pytest.mark.parametrize("load", [logic.logic_board, logic.board_size])
def test_missing_extra_is_named(monkeypatch, load):
    monkeypatch.setattr("repro.errors.find_spec", lambda _: None)
    with pytest.raises(InputError) as error:
        load()
    assert "'.[rtl]'" in str(error.value)


def test_installation_without_checkout_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(logic, "require", lambda *_: None)
    monkeypatch.setattr(logic.shutil, "which", lambda _: "/bin/true")
    monkeypatch.setattr(logic, "_CHECKOUT", tmp_path)
    with pytest.raises(InputError) as error:
        logic.logic_board()
    assert str(tmp_path) in str(error.value)
