"""Each way in which a map can be wrong: one MapError that names the file and says what to do."""

import contextlib
import struct
import warnings
import zlib

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from cohelm.errors import MapError
from cohelm.maps import MapWarning, OccupancyGrid, read_map, write_map
from cohelm.maps.nav2 import missing_rows

GOOD = {
    "image": "m.pgm",
    "resolution": 0.05,
    "origin": [0.0, 0.0, 0.0],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}


@pytest.fixture
def folder(tmp_path):
    Image.fromarray(np.full((20, 30), 254, dtype=np.uint8)).save(tmp_path / "m.pgm")
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(GOOD))
    return tmp_path


def refusal(file, **options) -> str:
    with pytest.raises(MapError) as caught:
        read_map(file, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert str(file) in message
    assert caught.value.code == "map"
    return message


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"resolution": 0}, "resolution: input should be greater than or equal to 0.0001"),
        ({"resolution": -0.05}, "resolution: input should be greater than or equal to 0.0001"),
        ({"resolution": float("nan")}, "resolution:"),
        ({"resolution": float("inf")}, "resolution: input should be a finite number"),
        ({"resolution": "fine"}, "resolution: input should be a valid number"),
        ({"origin": [0.0, 0.0]}, "origin: must be three numbers [x, y, yaw]"),
        ({"origin": [0.0, 0.0, 0.0, 0.0]}, "origin: must be three numbers"),
        ({"origin": 3}, "origin: must be three numbers"),
        ({"origin": [0.0, "left", 0.0]}, "origin.1: input should be a valid number"),
        ({"origin": [0.0, float("nan"), 0.0]}, "origin.1: input should be a finite number"),
        ({"free_thresh": 0.7}, "free_thresh (0.7) must not exceed occupied_thresh (0.65)"),
        ({"occupied_thresh": 65}, "occupied_thresh: input should be less than or equal to 1"),
        ({"free_thresh": -0.1}, "free_thresh: input should be greater than or equal to 0"),
        ({"mode": "binary"}, "mode: input should be 'trinary', 'scale' or 'raw', got 'binary'"),
        ({"negate": "perhaps"}, "negate:"),
        ({"image": ""}, "image:"),
        ({"ocupied_thresh": 0.6}, "ocupied_thresh: unknown; did you mean 'occupied_thresh'?"),
    ],
)
def test_a_yaml_that_says_what_cannot_be(folder, wrong, says):
    (folder / "m.yaml").write_text(yaml.safe_dump({**GOOD, **wrong}))
    assert says in refusal(folder / "m.yaml")


@pytest.mark.parametrize(
    "given",
    [
        {"map_type": "occupancy"},
        {"width": 100, "height": 200},
        {"layers": [{"name": "lifts"}]},
        {"image_width": 30, "origin_frame": "map"},
        {"comment": None, 3: "three"},
        {"mode": "trinary", "mode_name": "x"},
    ],
)
def test_a_key_of_others_is_left_out_and_named(folder, given):
    (folder / "m.yaml").write_text(yaml.safe_dump({**GOOD, **given}))
    with pytest.warns(MapWarning) as caught:
        assert read_map(folder / "m.yaml").shape == (20, 30)
    (told,) = [str(each.message) for each in caught]
    assert str(folder / "m.yaml") in told
    assert all(str(key) in told for key in given if key != "mode")


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("resolutoin", "resolution"),
        ("occupied_tresh", "occupied_thresh"),
        ("Resolution", "resolution"),
        ("imgae", "image"),
        ("orgin", "origin"),
        ("mdoe", "mode"),
        ("negat", "negate"),
        ("free_threshold", "free_thresh"),
    ],
)
@pytest.mark.parametrize("replaces", [True, False])
def test_a_misspelling_is_refused_with_the_key_that_is_meant(folder, key, meant, replaces):
    given = {k: v for k, v in GOOD.items() if k != meant} if replaces else GOOD
    (folder / "m.yaml").write_text(yaml.safe_dump({**given, key: GOOD.get(meant, 1)}))
    assert f"{key}: unknown; did you mean '{meant}'?" in refusal(folder / "m.yaml")


@pytest.mark.parametrize("key", ["image", "resolution", "origin", "occupied_thresh", "free_thresh"])
def test_a_key_that_nav2_requires_too_is_missing(folder, key):
    (folder / "m.yaml").write_text(yaml.safe_dump({k: v for k, v in GOOD.items() if k != key}))
    assert f"{key}: missing" in refusal(folder / "m.yaml")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("image: [m.pgm", "not YAML: line"),
        ("- image\n- m.pgm\n", "must be a mapping"),
        ("", "image: missing"),
        ("image: a\nimage: b\n", "given twice"),
    ],
)
def test_a_yaml_that_is_none(folder, text, says):
    (folder / "m.yaml").write_text(text)
    assert says in refusal(folder / "m.yaml")


def test_binary_rubbish_as_yaml(folder):
    (folder / "m.yaml").write_bytes(b"\xff\xfe\x00\x01")
    assert "cannot be read as text" in refusal(folder / "m.yaml")


def test_no_yaml_no_image_a_folder(folder):
    assert "no such file" in refusal(folder / "none.yaml")
    assert "no such file" in refusal(folder / "none.pgm")
    assert "is a folder" in refusal(folder)


def test_a_missing_image_says_where_it_was_looked_for(folder):
    (folder / "lab.yaml").write_text(yaml.safe_dump({**GOOD, "image": "hall.png"}))
    message = refusal(folder / "lab.yaml")
    for name in ("hall.png", "lab.pgm", "lab.png"):
        assert str(folder / name) in message


def image_refusal(folder, content: bytes, **options) -> str:
    (folder / "m.pgm").write_bytes(content)
    with pytest.raises(MapError) as caught:
        read_map(folder / "m.yaml", **options)
    assert str(folder / "m.pgm") in str(caught.value)
    return str(caught.value)


PIXELS = bytes(range(14, 44))
"""Rows of 6 pixels, all different and none of them white space."""


def pixels_of(folder, content: bytes):
    (folder / "m.pgm").write_bytes(content)
    (folder / "m.yaml").write_text(yaml.safe_dump({**GOOD, "mode": "raw"}))
    return read_map(folder / "m.yaml").data[::-1].reshape(-1).tolist()


@pytest.mark.parametrize(
    "header",
    [
        b"P5\n6 5\n255\n",
        b"P5\r\n6 5\r\n255\r\n",
        b"P5\r\n# by hand\r\n6 5\r\n255\r\n",
        b"P5 6 5 255 ",
        b"P5\n# one\n# two\n6 # columns\n5\n#three\n255\n",
        b"P5\r6 5\r255\r",
        b"P5\n\n6\t 5 \n\n255\n",
    ],
)
def test_the_pixels_begin_behind_any_header(folder, header):
    assert pixels_of(folder, header + PIXELS) == list(PIXELS)
    white = b"\n\r \t" + PIXELS[4:]  # pixels that look like white space
    assert pixels_of(folder, header + white) == list(white)


@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_pixels_in_words_need_no_place(folder, end):
    words = b" ".join(str(each).encode() for each in PIXELS) + end
    header = end.join([b"P2", b"# by hand", b"6 5", b"255", b"# pixels", b""])
    assert pixels_of(folder, header + words) == list(PIXELS)


@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_sixteen_bits_a_pixel(folder, end):
    deep = b"".join(struct.pack(">H", 257 * each) for each in PIXELS)
    header = end.join([b"P5", b"6 5", b"65535", b""])
    assert pixels_of(folder, header + deep) == list(PIXELS)


@pytest.mark.parametrize(
    ("header", "more"),
    [
        (b"P5\n6 5\n255\r\n", b""),
        (b"P5\n6 5\n255 \n", b""),
        (b"P5\n6 5\n255\n\n", b""),
        (b"P5\n6 5\n255 # white\n", b""),
        (b"P5\r\n6 5\r\n255\r\n", b"\n"),
        (b"P6\n2 5\n255\n\n", b""),
        (b"P4\n48 5\n\n", b""),
    ],
)
def test_pixels_with_an_uncertain_begin_are_refused(folder, header, more):
    assert "behind the header" in image_refusal(folder, header + PIXELS + more)


def test_a_crlf_header_with_a_pixel_missing_is_refused(folder):
    assert "damaged" in image_refusal(folder, b"P5\r\n6 5\r\n255\r\n" + PIXELS[1:])


def test_bytes_behind_the_last_pixel_are_told(folder):
    with pytest.warns(MapWarning, match="3 bytes behind the last pixel"):
        assert pixels_of(folder, b"P5\n6 5\n255\n" + PIXELS + b"end") == list(PIXELS)


def test_not_an_image(folder):
    assert "not an image" in image_refusal(folder, b"once upon a time")
    assert "not an image" in image_refusal(folder, b"")


@pytest.mark.parametrize("suffix", ["pgm", "png"])
@pytest.mark.parametrize("kept", [0.3, 0.7, 0.95])
def test_a_truncated_image(folder, suffix, kept):
    rng = np.random.default_rng(0)
    whole = folder / f"whole.{suffix}"
    Image.fromarray(rng.integers(0, 256, (64, 64), dtype=np.uint8)).save(whole)
    content = whole.read_bytes()
    assert "damaged" in image_refusal(folder, content[: int(kept * len(content))])


@pytest.mark.parametrize("mode", ["L", "RGBA", "1", "P"])
def test_a_png_that_lacks_rows(folder, mode):
    whole = folder / "whole.png"
    Image.new(mode, (50, 40), 1 if mode in "1P" else "white").save(whole)
    content = whole.read_bytes()
    assert missing_rows(whole) == 0
    at = content.index(b"IHDR") + 8
    taller = content[:at] + struct.pack(">I", 60) + content[at + 4 :]
    end = at - 4 + 13
    taller = taller[:end] + struct.pack(">I", zlib.crc32(taller[at - 8 : end])) + taller[end + 4 :]
    assert "20 of 60 rows are missing" in image_refusal(folder, taller)


@pytest.mark.parametrize("header", [b"P5\n0 10\n255\n", b"P5\n10 0\n255\n", b"P5\n-3 5\n255\n"])
def test_sizes_that_hold_nothing(folder, header):
    image_refusal(folder, header + bytes(100))


def png_header(width: int, height: int) -> bytes:
    """A PNG that declares its size and holds no pixels."""
    body = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    data = b"IDAT"
    return b"".join(
        [
            b"\x89PNG\r\n\x1a\n",
            struct.pack(">I", 13), body, struct.pack(">I", zlib.crc32(body)),
            struct.pack(">I", 0), data, struct.pack(">I", zlib.crc32(data)),
        ]
    )  # fmt: skip


@pytest.mark.parametrize(
    "bomb", [b"P5\n12000 10000\n255\n", png_header(12_000, 10_000), png_header(60_000, 60_000)]
)
def test_a_bomb_is_refused_by_its_header(folder, bomb):
    # 12000 x 10000 = 120 million and more; none of these files holds a single pixel
    message = image_refusal(folder, bomb)
    assert "limit of 100000000" in message
    assert "damaged" not in message


def test_the_limit_is_a_limit_and_not_one_less(folder):
    assert read_map(folder / "m.yaml", pixel_limit=600).shape == (20, 30)
    assert "30 x 20 pixels are more than the limit of 599" in image_refusal(
        folder, (folder / "m.pgm").read_bytes(), pixel_limit=599
    )


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    suffix=st.sampled_from(["pgm", "png"]),
    wrong=st.lists(st.tuples(st.integers(0, 119), st.integers(0, 255)), min_size=1, max_size=4),
    kept=st.integers(0, 800),
)
def test_damage_of_any_kind_is_a_map_error_or_another_map(folder, suffix, wrong, kept):
    file = folder / f"damaged.{suffix}"
    Image.fromarray((np.arange(600) % 256).astype(np.uint8).reshape(20, 30)).save(file)
    content = bytearray(file.read_bytes())
    for at, byte in wrong:
        content[at % len(content)] = byte
    file.write_bytes(bytes(content[:kept]))
    with warnings.catch_warnings(), contextlib.suppress(MapError):
        warnings.simplefilter("ignore", MapWarning)
        assert set(np.unique(read_map(file, pixel_limit=10**6).data)) <= {-1, 0, 100}


def test_what_is_no_image_is_refused_without_a_word_before(tmp_path):
    """No warning of what it would be taken for: it would be an error here."""
    file = tmp_path / "notes.pgm"
    file.write_text("not a map")
    with pytest.raises(MapError, match="not an image"):
        read_map(file)


def test_what_cannot_be_written(tmp_path):
    grid = OccupancyGrid(data=np.zeros((2, 2), dtype=np.int8), resolution=0.05, X_MG=np.zeros(3))
    with pytest.raises(MapError, match=r"must end in .yaml"):
        write_map(grid, tmp_path / "m.pgm")
    with pytest.raises(MapError, match="use pgm or png"):
        write_map(grid, tmp_path / "m.yaml", "gif")
    with pytest.raises(MapError, match="cannot be written"):
        write_map(grid, tmp_path / "nowhere" / "m.yaml")
