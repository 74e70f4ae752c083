#!/usr/bin/python3
"""What scripts/measure reads and writes by itself; the figures are the program's."""

import importlib.machinery
import importlib.util
import json
import pathlib
import struct
import sys
import tempfile
import unittest
import zlib

sys.dont_write_bytecode = True
SCRIPT = pathlib.Path(sys.argv.pop(1)).resolve()
loader = importlib.machinery.SourceFileLoader("measure", str(SCRIPT))
measure = importlib.util.module_from_spec(importlib.util.spec_from_loader("measure", loader))
loader.exec_module(measure)


def paeth(left, above, corner):
    """As the PNG specification writes it, 9.4."""
    p = left + above - corner
    pa, pb, pc = abs(p - left), abs(p - above), abs(p - corner)
    if pa <= pb and pa <= pc:
        return left
    return above if pb <= pc else corner


def write_png(path, rows, channels, kinds):
    """Filters each row by the kind that is given for it."""
    filtered, above = b"", bytes(len(rows[0]))
    for row, kind in zip(rows, kinds):
        filtered += bytes([kind])
        for x, value in enumerate(row):
            left, corner = (row[x - channels], above[x - channels]) if x >= channels else (0, 0)
            guess = [0, left, above[x], (left + above[x]) // 2, paeth(left, above[x], corner)][kind]
            filtered += bytes([(value - guess) % 256])
        above = row
    width = len(rows[0]) // channels
    header = struct.pack(">IIBBBBB", width, len(rows), 8, {1: 0, 3: 2}[channels], 0, 0, 0)
    packed = zlib.compress(filtered)
    chunks = [(b"IHDR", header), (b"IDAT", packed[:7]), (b"IDAT", packed[7:]), (b"IEND", b"")]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks))


class Measure(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_reads_all_filters_of_png(self):
        rows = [bytes((x * x * (y + 3) + 71 * y) % 256 for x in range(21)) for y in range(6)]
        for channels in (1, 3):
            file = self.folder / "a.png"
            write_png(file, rows, channels, [4, 1, 2, 3, 4, 0])
            self.assertEqual(measure.read_png(file), (b"".join(rows), channels))

    def test_difference_is_over_the_object(self):
        for name, codes in (("one", [10, 10, 10, 10]), ("other", [10, 16, 10, 18])):
            write_png(self.folder / name / "composite/000000.png", [bytes(c for c in codes for _ in "rgb")], 3, [0])
            write_png(self.folder / name / "mask/000000.png", [bytes([0, 255, 128, 255])], 1, [0])
        # 6 and 8 code values, over 2 pixels of the object.
        self.assertAlmostEqual(measure.rms_difference(self.folder / "one", self.folder / "other"), 50**0.5)

    def test_a_short_sequence_is_without_truth(self):
        recording = self.folder / "recording"
        (recording / "truth").mkdir(parents=True)
        (recording / "scene.obj").write_text("v 0 0 0\n", encoding="utf-8")
        frames = {"frames": [{"image": "%d.exr" % i} for i in range(7)]}
        (recording / "sequence.json").write_text(json.dumps(frames), encoding="utf-8")
        short = measure.shorten(recording, self.folder, 3)
        self.assertEqual(sorted(entry.name for entry in short.iterdir()), ["scene.obj", "sequence.json"])
        kept = measure.read_json(short / "sequence.json")["frames"]
        self.assertEqual([frame["image"] for frame in kept], ["0.exr", "3.exr", "6.exr"])

    def test_writes_between_the_marks_alone(self):
        measure.ROOT, measure.PAGE = self.folder, self.folder / "page.md"
        page = "a\n<!-- measured: sun -->\n%s<!-- end -->\nb\n<!-- measured: time -->\nt\n<!-- end -->\n"
        measure.PAGE.write_text(page % "old\n", encoding="utf-8")
        (self.folder / "sun.md").write_text(r"new \1" + "\n", encoding="utf-8")
        measure.write_page(self.folder)
        self.assertEqual(measure.PAGE.read_text(encoding="utf-8"), page % "new \\1\n")
        (self.folder / "light.md").write_text("new\n", encoding="utf-8")
        with self.assertRaisesRegex(SystemExit, "page.md: expected <!-- measured: light -->"):
            measure.write_page(self.folder)

    def test_numbers_have_two_digits_that_count(self):
        written = [measure.number(value) for value in (0.00456, 0.0512, 0.513, 2.72, 41.6, 207.4, 0, None)]
        self.assertEqual(written, ["0.0046", "0.051", "0.51", "2.7", "42", "207", "0", "-"])


if __name__ == "__main__":
    unittest.main()
