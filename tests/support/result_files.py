"""Results directories as the commands leave them, but with a few bytes in each file."""

import json

SUMMARY = json.dumps({"provenance": {"software": "worm-escape"}, "complete": True})
TABLES = ("tracks.parquet", "contacts.parquet", "passages.parquet", "sums.parquet")


def write_result(directory, text, *, report=True):
    """Write every file of a trial's results, each with `text` in it, the summary last."""
    (directory / "bag").mkdir(parents=True)
    names = [*TABLES, "bag/metadata.yaml", "bag/bag.mcap"]
    if report:
        names.append("report.html")
    for name in names:
        (directory / name).write_text(text)
    (directory / "summary.json").write_text(SUMMARY)


def result_text(directory):
    """Return the text of a result that is whole; fail where it is not all from one run."""
    assert (directory / "summary.json").read_text() == SUMMARY
    names = (*TABLES, "bag/metadata.yaml", "bag/bag.mcap")
    (text,) = {(directory / name).read_text() for name in names}
    return text


def files_in(directory):
    """Return the content of every file below a directory, by its path; links by their target."""
    return {
        str(path.relative_to(directory)): str(path.readlink())
        if path.is_symlink()
        else path.read_bytes()
        for path in directory.rglob("*")
        if path.is_symlink() or path.is_file()
    }
