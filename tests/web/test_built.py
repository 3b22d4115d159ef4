import gzip

import pytest

from cohelm.errors import ConfigError
from cohelm.web.page_files import read_page


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<!doctype html>" + 100 * "<p>rider</p>")
    (tmp_path / "therapist.html").write_text("<!doctype html><p>therapist</p>")
    (tmp_path / "assets" / "a-1.js").write_text("let a = 1;\n" * 100)
    (tmp_path / "secret.pem").write_text("no part of a page")
    return tmp_path


def test_the_page_has_two_doors_and_nothing_but_itself(folder):
    page = read_page(folder)
    assert page[""] is page["index.html"]
    assert page["therapist"] is page["therapist.html"]
    assert "secret.pem" not in page
    assert page["assets/a-1.js"].lasting
    assert not page[""].lasting


def test_what_is_compressed_is_the_same_and_shorter(folder):
    script = read_page(folder)["assets/a-1.js"]
    assert gzip.decompress(script.zipped) == script.body
    assert len(script.zipped) < len(script.body)


def test_without_a_view_of_its_own_the_therapist_gets_the_page(folder):
    (folder / "therapist.html").unlink()
    page = read_page(folder)
    assert page["therapist"] is page[""]


def test_a_page_that_was_not_built_says_how_to_build_it(tmp_path):
    with pytest.raises(ConfigError, match="make page"):
        read_page(tmp_path)
