"""Self-signed certificate of the chair, if the user has given none."""

from __future__ import annotations

import datetime
import hashlib
import ipaddress
import os
import ssl
from collections.abc import Sequence
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from cohelm.arrays import value
from cohelm.errors import ConfigError

VALIDITY = datetime.timedelta(days=365)
"""Time for which a new certificate is valid."""
_RENEWAL_MARGIN = datetime.timedelta(days=14)
"""Remaining validity below which a certificate is renewed."""


@value
class Tls:
    """Certificate and its key, as PEM files."""

    certificate: Path
    key: Path

    def context(self) -> ssl.SSLContext:
        """Return the context of a server: TLS 1.2 and newer.

        Raises:
            ConfigError: The files are not a certificate and its key without a password.
        """
        made = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        made.minimum_version = ssl.TLSVersion.TLSv1_2
        try:
            made.load_cert_chain(self.certificate, self.key, password=_no_password)
        except (OSError, ValueError) as cause:  # ssl.SSLError is an OSError
            what = f"not a certificate (PEM) and its own key without a password ({cause})"
            raise ConfigError(what, file=self.certificate, key="--cert") from None
        return made

    def fingerprint(self) -> str:
        """SHA-256 of the certificate, as browsers show it."""
        pem = ssl.PEM_cert_to_DER_cert(self.certificate.read_text(encoding="ascii"))
        return ":".join(f"{byte:02X}" for byte in hashlib.sha256(pem).digest())


def own_certificate(folder: Path, names: Sequence[str], now: datetime.datetime) -> Tls:
    """Return the certificate in ``folder``; a new, self-signed one if that is not valid.

    It is stored, so that browsers need to be told only once to trust it.

    Args:
        folder: Created if it is missing, for this user alone.
        names: Host names and addresses for which it must be valid.
        now: With a time zone.

    Raises:
        ConfigError: The folder cannot be written.
    """
    tls = Tls(certificate=folder / "certificate.pem", key=folder / "key.pem")
    try:
        if not _is_valid(tls, names, now):
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            _make(tls, names, now)
    except OSError as cause:
        what = f"no certificate can be kept here ({cause.strerror or cause})"
        raise ConfigError(what, file=folder, key="--data") from None
    return tls


def _is_valid(tls: Tls, names: Sequence[str], now: datetime.datetime) -> bool:
    if not (tls.certificate.is_file() and tls.key.is_file()):
        return False
    try:
        kept = x509.load_pem_x509_certificate(tls.certificate.read_bytes())
        tls.context()
        good_for = kept.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (ValueError, ConfigError, x509.ExtensionNotFound):
        return False
    return kept.not_valid_after_utc > now + _RENEWAL_MARGIN and set(map(_name, names)) <= set(
        good_for
    )


def _make(tls: Tls, names: Sequence[str], now: datetime.datetime) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    who = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "cohelm")])
    made = (
        x509.CertificateBuilder()
        .subject_name(who)
        .issuer_name(who)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + VALIDITY)
        .add_extension(x509.SubjectAlternativeName([_name(each) for each in names]), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .sign(key, hashes.SHA256())
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    tls.key.unlink(missing_ok=True)
    with os.fdopen(os.open(tls.key, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(secret)
    tls.certificate.write_bytes(made.public_bytes(serialization.Encoding.PEM))


def _name(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)


def _no_password() -> bytes:
    raise ValueError("the key has a password")
