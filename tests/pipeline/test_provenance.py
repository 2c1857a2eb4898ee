"""What a run says of the code that made it."""

import subprocess

from repro.pipeline.provenance import commit


def test_the_commit_is_that_of_the_checkout_and_a_change_is_told(tmp_path):
    def git(*arguments):
        name = ("-c", "user.name=A", "-c", "user.email=a@example.org")
        run = subprocess.run(["git", *name, *arguments], cwd=tmp_path, check=True, capture_output=True, text=True)
        return run.stdout.strip()

    assert commit(tmp_path) == "unknown"
    git("init", "-q")
    (tmp_path / "file").write_text("one")
    git("add", "file")
    git("commit", "-q", "-m", "one")
    assert commit(tmp_path) == git("rev-parse", "HEAD")
    (tmp_path / "file").write_text("two")
    assert commit(tmp_path) == git("rev-parse", "HEAD") + "-dirty"
