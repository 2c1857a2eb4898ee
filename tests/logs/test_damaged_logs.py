"""Files that are not there, and damage of any kind: one line, never a traceback."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_example import columns, recording, text

from repro.errors import InputError
from repro.logs.armfile import Arm
from repro.logs.diagnostics import describe
from repro.logs.load import read_log
from repro.logs.log import uniform


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(InputError, match=r"log\.csv: found No such file or directory, expected a CSV table"):
        read_log(tmp_path / "log.csv", Arm())
    with pytest.raises(InputError, match="found a folder, expected a CSV table"):
        read_log(tmp_path, Arm())
    with pytest.raises(InputError, match=r"log\.bin: found No such file"):
        read_log(tmp_path / "log.bin", Arm())


@pytest.mark.slow
@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    edits=st.lists(
        st.sampled_from([b"", b",", b"\n", b"-", b"1e400", b"9e99", b"nan", b"#", b'"', b"\xff", b";"]), max_size=4
    ),
)
def test_damage_never_breaks_the_reader(tmp_path_factory, seed, edits):
    rng = np.random.default_rng(seed)
    data = text(columns(recording(np.arange(300) / 100.0)), 5).encode()
    for edit in edits:
        place = int(rng.integers(len(data)))
        data = data[:place] + edit + data[place + int(rng.integers(3)) :]
    path = tmp_path_factory.mktemp("damaged") / "log.csv"
    path.write_bytes(data)
    try:
        log = read_log(path, Arm())
        describe(log, Arm())
        even = uniform(log)
    except InputError as error:
        assert "\n" not in str(error)
        assert "log.csv" in str(error)
    else:
        assert even.q.shape == even.tau.shape == (2, even.t.size)
        assert np.isfinite(even.q).all()
        assert np.isfinite(even.tau).all()
