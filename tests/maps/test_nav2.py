"""The semantics of Nav2's map files, derived by hand, and the round trip."""

import warnings
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from cohelm.maps import MapWarning, OccupancyGrid, read_map, write_map


def make_map(folder: Path, pixels, *, suffix=".pgm", **about) -> Path:
    image = pixels if isinstance(pixels, Image.Image) else Image.fromarray(np.uint8(pixels))
    image.save(folder / f"m{suffix}")
    given = {
        "image": f"m{suffix}",
        "resolution": 0.05,
        "origin": [0.0, 0.0, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    file = folder / "m.yaml"
    file.write_text(yaml.safe_dump({**given, **about}))
    return file


def read_row(folder: Path, shades, **about) -> list[int]:
    return read_map(make_map(folder, [shades], **about)).data[0].tolist()


class TestTrinary:
    def test_the_usual_shades(self, tmp_path):
        # p = 255/255, 50/255 = 0.1961 (just above 0.196), 1/255, 0
        assert read_row(tmp_path, [0, 205, 254, 255]) == [100, -1, 0, 0]

    def test_with_nav2s_other_default_205_is_free_and_that_is_said(self, tmp_path):
        with pytest.warns(MapWarning, match="takes 1 pixels of shade 205"):
            assert read_row(tmp_path, [0, 205, 254], free_thresh=0.25) == [100, 0, 0]

    def test_both_thresholds_belong_to_their_side(self, tmp_path):
        # p(204) = 51/255 = 0.2 = free_thresh, p(102) = 153/255 = 0.6 = occupied_thresh
        shades = [101, 102, 103, 203, 204, 205]
        with pytest.warns(MapWarning, match="shade 205"):
            found = read_row(tmp_path, shades, free_thresh=0.2, occupied_thresh=0.6)
        assert found == [100, 100, -1, -1, 0, 0]

    def test_every_threshold_that_a_shade_can_meet_includes_it(self, tmp_path):
        for k in (5, 10, 15, 17, 51, 85):
            p = k / 255.0
            shades = [255 - k - 1, 255 - k, 255 - k + 1]
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", MapWarning)
                assert read_row(tmp_path, shades, free_thresh=p, occupied_thresh=1.0)[1:] == [0, 0]
                assert read_row(tmp_path, shades, free_thresh=0.0, occupied_thresh=p) == [
                    100, 100, -1,
                ]  # fmt: skip

    def test_negate_makes_light_occupied(self, tmp_path):
        # p = x/255: 0, 0.196078 (unknown by a hair), 0.2, 0.647 (unknown), 0.651, 1
        shades = [0, 49, 50, 165, 166, 255]
        for negate in (1, True):
            assert read_row(tmp_path, shades, negate=negate) == [0, 0, -1, -1, 100, 100]


class TestScale:
    def test_grades_between_the_thresholds(self, tmp_path):
        # thresholds 0.2 and 0.6, p = (255 − x)/255, value = 100·(p − 0.2)/0.4
        #   x = 204: p = 0.2, at the threshold      → 0
        #   x = 178: p = 77/255 = 0.30196, 25.49    → 25
        #   x = 153: p = 0.4                        → 50
        #   x = 140: p = 115/255 = 0.45098, 62.745  → 63
        #   x = 102: p = 0.6, at the threshold      → 100
        shades = [255, 204, 178, 153, 140, 102, 0]
        found = read_row(tmp_path, shades, mode="scale", free_thresh=0.2, occupied_thresh=0.6)
        assert found == [0, 0, 25, 50, 63, 100, 100]

    def test_nothing_is_unknown_without_transparency(self, tmp_path):
        found = read_row(tmp_path, range(256), mode="scale")
        assert min(found) == 0
        assert max(found) == 100
        assert found == sorted(found, reverse=True)

    def test_thresholds_that_meet_leave_nothing_between(self, tmp_path):
        found = read_row(tmp_path, [0, 127, 128, 255], mode="scale",
                         free_thresh=0.5, occupied_thresh=0.5)  # fmt: skip
        assert found == [100, 100, 0, 0]


class TestRaw:
    def test_the_shade_is_the_value_up_to_100_and_negate_does_not_count(self, tmp_path):
        shades = [0, 1, 50, 100, 101, 127, 128, 205, 255]
        expected = [0, 1, 50, 100, -1, -1, -1, -1, -1]
        assert read_row(tmp_path, shades, mode="raw") == expected
        assert read_row(tmp_path, shades, mode="raw", negate=1) == expected


class TestImages:
    def test_rows_are_flipped_and_the_origin_is_honoured(self, tmp_path):
        file = make_map(tmp_path, [[0, 254], [254, 254]], origin=[1.0, 2.0, np.pi / 2])
        grid = read_map(file)
        assert grid.data.tolist() == [[0, 0], [100, 0]]
        # the dark pixel is at the upper left: grid coordinates (0.025, 0.075), turned by 90°
        assert grid.centres([1, 0]) == pytest.approx([1.0 - 0.075, 2.0 + 0.025])

    @pytest.mark.parametrize("mode", ["trinary", "scale"])
    def test_any_transparency_is_unknown(self, tmp_path, mode):
        pixels = np.zeros((1, 3, 4), dtype=np.uint8)
        pixels[0, :, 3] = [255, 254, 0]  # opaque, nearly so, not at all
        file = make_map(tmp_path, Image.fromarray(pixels), suffix=".png", mode=mode)
        assert read_map(file).data.tolist() == [[100, -1, -1]]

    def test_raw_does_not_look_at_transparency(self, tmp_path):
        pixels = np.full((1, 1, 2), [42, 0], dtype=np.uint8)
        file = make_map(tmp_path, Image.fromarray(pixels), suffix=".png", mode="raw")
        assert read_map(file).data.tolist() == [[42]]

    def test_a_transparent_palette_entry_is_unknown(self, tmp_path):
        image = Image.fromarray(np.array([[0, 1]], dtype=np.uint8), mode=None).convert("P")
        image.putpalette([0, 0, 0, 255, 255, 255])
        image.putdata([0, 1])
        image.info["transparency"] = 1
        file = make_map(tmp_path, image, suffix=".png")
        assert read_map(file).data.tolist() == [[100, -1]]

    def test_colours_count_by_their_lightness(self, tmp_path):
        # Rec. 601: red 0.299·255 = 76 → p = 0.70 occupied; green 0.587·255 = 150 → p = 0.41 unknown
        pixels = np.array([[[255, 0, 0], [0, 255, 0], [255, 255, 255]]], dtype=np.uint8)
        file = make_map(tmp_path, Image.fromarray(pixels), suffix=".png")
        assert read_map(file).data.tolist() == [[100, -1, 0]]

    def test_sixteen_bits_are_read_as_eight(self, tmp_path):
        deep = np.array([[0, 205 * 257, 65535]], dtype=np.uint16)
        for suffix in (".png", ".pgm"):
            file = make_map(tmp_path, Image.fromarray(deep), suffix=suffix)
            assert read_map(file).data.tolist() == [[100, -1, 0]]

    def test_a_plain_pgm_with_comments_and_another_white(self, tmp_path):
        file = make_map(tmp_path, [[0]])
        (tmp_path / "m.pgm").write_text("P2\n# by hand\n3 1\n# white is 100\n100\n0 80 100\n")
        # 80/100 → 204 → p = 0.2: unknown; 100/100 → free
        assert read_map(file).data.tolist() == [[100, -1, 0]]


class TestWhichImage:
    def test_the_yamls_own_stem_stands_in_and_that_is_said(self, tmp_path):
        file = make_map(tmp_path, [[0]], image="gone/lab.pgm")
        with pytest.warns(MapWarning, match=r"'gone/lab.pgm' does not exist; 'm.pgm' was read"):
            assert read_map(file).data.tolist() == [[100]]

    def test_an_image_alone_is_taken_with_usual_values_and_that_is_said(self, tmp_path):
        make_map(tmp_path, [[0, 205, 254]])
        with pytest.warns(MapWarning, match=r"m.pgm: .*0.05 m a pixel"):
            grid = read_map(tmp_path / "m.pgm")
        assert grid.data.tolist() == [[100, -1, 0]]
        assert grid.resolution == 0.05
        assert grid.X_MG.tolist() == [0.0, 0.0, 0.0]

    def test_an_absolute_name_and_a_name_as_text_go(self, tmp_path):
        make_map(tmp_path, [[0]])
        (tmp_path / "deep").mkdir()
        about = yaml.safe_load((tmp_path / "m.yaml").read_text())
        file = tmp_path / "deep" / "n.yaml"
        file.write_text(yaml.safe_dump({**about, "image": str(tmp_path / "m.pgm")}))
        assert read_map(str(file)).data.tolist() == [[100]]

    def test_the_mode_may_be_left_out_or_written_large(self, tmp_path):
        assert read_row(tmp_path, [42], mode="RAW") == [42]
        file = make_map(tmp_path, [[0]])
        about = yaml.safe_load(file.read_text())
        del about["negate"]
        file.write_text(yaml.safe_dump(about))
        assert read_map(file).data.tolist() == [[100]]


shapes = hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12)
values = st.sampled_from([-1, 0, 100]) | st.integers(-1, 100)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    data=hnp.arrays(np.int8, shapes, elements=st.sampled_from([-1, 0, 100]))
    | hnp.arrays(np.int8, shapes, elements=values),
    resolution=st.floats(1e-3, 10.0),
    origin=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    image_format=st.sampled_from(["pgm", "png"]),
)
def test_what_was_written_is_read_to_the_last_bit(tmp_path, data, resolution, origin, image_format):
    grid = OccupancyGrid(data=data, resolution=resolution, X_MG=np.array(origin))
    write_map(grid, tmp_path / "out.yaml", image_format)
    again = read_map(tmp_path / "out.yaml")
    assert np.array_equal(again.data, grid.data)
    assert again.resolution == grid.resolution
    assert again.X_MG.tobytes() == grid.X_MG.tobytes()


def test_a_written_map_is_one_that_nav2_reads(tmp_path):
    data = np.array([[-1, 0, 100]], dtype=np.int8)
    write_map(
        OccupancyGrid(data=data, resolution=0.05, X_MG=np.array([1.0, 2.0, 0.5])),
        tmp_path / "m.yaml",
    )
    assert yaml.safe_load((tmp_path / "m.yaml").read_text()) == {
        "image": "m.pgm",
        "mode": "trinary",
        "resolution": 0.05,
        "origin": [1.0, 2.0, 0.5],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    assert np.asarray(Image.open(tmp_path / "m.pgm")).tolist() == [[205, 254, 0]]
