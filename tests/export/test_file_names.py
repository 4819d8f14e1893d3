"""Safe names of files: no two alike on any system."""

from flatnet.export.file_names import safe_file_names


def test_names_are_safe_and_distinct_whatever_the_case():
    names = ["sole", "Sole", "SOLE", "sole-2", "a/b", "a\\b", "..", "", "con", "Aux", "LPT1", "-x"]
    names += ["Zehe ä", "口"]
    safe = safe_file_names(names)
    assert list(safe) == names
    assert len({name.lower() for name in safe.values()}) == len(names)
    assert safe["sole"] == "sole" and safe["Zehe ä"] == "Zehe_a"
    for name in safe.values():
        assert name and set(name) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_")
        assert not name.startswith("-")
        assert name.lower() not in {"con", "aux", "lpt1"}


def test_long_names_stay_short_and_distinct():
    safe = safe_file_names(["x" * 300, "x" * 301])
    assert len(set(safe.values())) == 2 and max(map(len, safe.values())) <= 110
