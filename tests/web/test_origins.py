import pytest

from cohelm.errors import ConfigError
from cohelm.web.origins import is_everywhere, is_loopback, name_of, origins_for

LOOPBACK = origins_for("127.0.0.1", tls=False)
PAGE = {"host": "127.0.0.1:8000", "origin": "http://127.0.0.1:8000"}


def asked(origins, headers, **about):
    given = [(name.encode(), text.encode("latin-1")) for name, text in headers.items()]
    return origins.refusal(given, **about)


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "127.0.0.1:8000", "localhost:9", "LocalHost", "[::1]:8000", "[::1]"]
)
def test_the_machine_itself_is_known_by_all_its_names(host):
    assert asked(LOOPBACK, {"host": host}) is None


@pytest.mark.parametrize(
    "host",
    [
        "", "evil.example", "evil.example:8000", "127.0.0.1.evil.example", "localhost.evil.example",
        "localhost@evil.example", "127.0.0.1:80x", "[::1", "[::1]x", "192.168.0.7:8000",
        "0.0.0.0:8000", "localhost:8000/evil", "lo\xe7alhost",
    ],
)  # fmt: skip
def test_other_names_are_refused(host):
    assert asked(LOOPBACK, {"host": host}).status == 421


def test_one_host_and_no_less():
    assert LOOPBACK.refusal([]).status == 400
    assert LOOPBACK.refusal([(b"host", b"localhost")] * 2).status == 400


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example", "https://127.0.0.1:8000", "http://127.0.0.1:3000",
        "http://localhost:8000", "http://127.0.0.1", "null", "", "file://",
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    "about", [{"is_socket": True}, {"method": "POST"}, {"method": "GET", "path": "/api/me"}]
)
def test_a_page_of_another_origin_is_refused(origin, about):
    """Also another server on this machine, and the same address by another name."""
    assert asked(LOOPBACK, {**PAGE, "origin": origin}, **about).status == 403


@pytest.mark.parametrize("about", [{"is_socket": True}, {"method": "PUT"}, {"method": "DELETE"}])
def test_who_changes_something_says_where_they_come_from(about):
    assert asked(LOOPBACK, {"host": PAGE["host"]}, **about).status == 403
    assert asked(LOOPBACK, PAGE, **about) is None


def test_reading_needs_no_origin_but_no_foreign_page_either():
    host = {"host": PAGE["host"]}
    assert asked(LOOPBACK, host, path="/api/limits") is None
    foreign = {**host, "sec-fetch-site": "cross-site"}
    assert asked(LOOPBACK, foreign, path="/api/floor/a.png").status == 403
    assert asked(LOOPBACK, foreign, path="/") is None  # a link leads here


def test_a_forwarded_port_is_the_same_machine():
    """As ssh -L 9000:localhost:8000 does it: the page's own origin has that port as well."""
    forwarded = {"host": "localhost:9000", "origin": "http://localhost:9000"}
    assert asked(LOOPBACK, forwarded, is_socket=True) is None


@pytest.mark.parametrize("site", ["foo", "", "foxglove.dev", "https://a.example/path", "https:"])
def test_a_viewer_that_is_no_address_of_a_site_is_refused(site):
    with pytest.raises(ConfigError, match="--viewer"):
        origins_for("127.0.0.1", tls=False, viewers=[site])


def test_on_all_addresses_the_one_it_came_in_by_is_a_name():
    origins = origins_for("0.0.0.0", tls=True, names=("Chair",))
    page = {"host": "192.168.0.7:8000", "origin": "https://192.168.0.7:8000"}
    assert asked(origins, page, is_socket=True, local="192.168.0.7") is None
    assert asked(origins, page, is_socket=True, local="::ffff:192.168.0.7") is None
    assert asked(origins, page, is_socket=True, local="192.168.0.8").status == 421
    assert asked(origins, {"host": "chair:8000"}) is None
    assert asked(origins, {"host": ""}, local="").status == 421


@pytest.mark.parametrize(
    ("host", "loopback", "everywhere"),
    [
        ("127.0.0.1", True, False), ("127.9.9.9", True, False), ("localhost", True, False),
        ("::1", True, False), ("[::1]", True, False), ("0.0.0.0", False, True),
        ("::", False, True), ("192.168.0.7", False, False), ("chair.local", False, False),
        ("localhost.evil.example", False, False), ("", False, False),
    ],
)  # fmt: skip
def test_who_can_reach_a_host(host, loopback, everywhere):
    assert is_loopback(host) is loopback
    assert is_everywhere(host) is everywhere


def test_a_name_is_told_from_its_port():
    assert name_of("Chair:80") == "chair"
    assert name_of("[fe80::1]:80") == "fe80::1"
    assert name_of("chair:") == ""
