import datetime
import ssl
import stat

import pytest
from cryptography import x509

from cohelm.errors import ConfigError
from cohelm.web.certificate import VALIDITY, Tls, own_certificate

NOW = datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC)
NAMES = ("192.168.0.7", "chair", "::1")


def test_it_is_good_for_its_names_and_its_key_is_secret(tmp_path):
    tls = own_certificate(tmp_path / "tls", NAMES, NOW)
    made = x509.load_pem_x509_certificate(tls.certificate.read_bytes())
    names = made.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert [str(each.value) for each in names] == list(NAMES)
    assert made.not_valid_after_utc == NOW + VALIDITY
    assert stat.S_IMODE(tls.key.stat().st_mode) == 0o600
    assert stat.S_IMODE(tls.key.parent.stat().st_mode) == 0o700
    assert tls.context().minimum_version == ssl.TLSVersion.TLSv1_2
    assert len(tls.fingerprint()) == 32 * 3 - 1


def test_it_is_kept_as_long_as_it_suits(tmp_path):
    first = own_certificate(tmp_path, NAMES, NOW).fingerprint()
    later = NOW + datetime.timedelta(days=300)
    assert own_certificate(tmp_path, NAMES[:1], later).fingerprint() == first
    assert own_certificate(tmp_path, ("other",), later).fingerprint() != first


@pytest.mark.parametrize("days", [352, 400])
def test_one_that_ends_soon_or_has_ended_is_made_anew(tmp_path, days):
    first = own_certificate(tmp_path, NAMES, NOW).fingerprint()
    later = NOW + datetime.timedelta(days=days)
    assert own_certificate(tmp_path, NAMES, later).fingerprint() != first


@pytest.mark.parametrize("broken", ["certificate", "key"])
def test_a_damaged_one_is_made_anew(tmp_path, broken):
    tls = own_certificate(tmp_path, NAMES, NOW)
    getattr(tls, broken).write_text("nonsense")
    own_certificate(tmp_path, NAMES, NOW).context()


def test_what_is_no_certificate_is_refused_by_name(tmp_path):
    for name in ("a.pem", "b.pem"):
        (tmp_path / name).write_text("nonsense")
    with pytest.raises(ConfigError, match=r"a\.pem: --cert"):
        Tls(certificate=tmp_path / "a.pem", key=tmp_path / "b.pem").context()
    with pytest.raises(ConfigError, match="--cert"):
        Tls(certificate=tmp_path / "missing.pem", key=tmp_path / "b.pem").context()


def test_a_folder_that_is_none_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="--data"):
        own_certificate(tmp_path / "file" / "tls", NAMES, NOW)
