#!/usr/bin/env python3
"""README.md and the pages in docs/ are easy to read: paragraphs, sentences and table cells are short.

Usage: documents_test.py SOURCE_DIR

Code and headings are not checked. A link counts as its text.
"""

import pathlib
import re
import sys

MOST_LINES = 5  # Of a paragraph, or of an item of a list.
MOST_WORDS = 30  # Of a sentence.
MOST_CHARACTERS = 120  # Of a cell.


def without_links(text: str) -> str:
    return re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)


def paragraphs_and_rows(page: str) -> tuple:
    """Two lists of (line number, lines or line)."""
    paragraphs, rows, paragraph = [], [], []
    is_code = False
    for number, line in enumerate(page.split("\n") + [""], 1):
        is_fence = line.startswith("```")
        is_row = line.startswith("|")
        is_item = re.match(r"\s*([-*]|\d+\.) ", line) is not None
        is_other = is_code or not line.strip() or line.startswith(("#", "<!--"))
        if paragraph and (is_fence or is_row or is_item or is_other):
            paragraphs.append((number - len(paragraph), paragraph))
            paragraph = []
        if is_row and not is_code:
            rows.append((number, line))
        elif not is_fence and not is_other and (paragraph or is_item or not line.startswith("    ")):
            paragraph.append(line)
        is_code ^= is_fence
    return paragraphs, rows


def faults_of(page: str) -> list:
    faults = []
    paragraphs, rows = paragraphs_and_rows(page)
    for number, lines in paragraphs:
        if len(lines) > MOST_LINES:
            faults.append((number, f"paragraph of {len(lines)} lines"))
        text = without_links(" ".join(line.strip() for line in lines))
        for sentence in re.split(r"(?<=[.!?])\s+", text):
            words = sum(1 for word in sentence.split() if re.search(r"\w", word))
            if words > MOST_WORDS:
                faults.append((number, f"sentence of {words} words: {sentence[:60]}..."))
    for number, row in rows:
        for cell in without_links(row).strip().strip("|").split(" | "):
            if len(cell.strip()) > MOST_CHARACTERS:
                faults.append((number, f"cell of {len(cell.strip())} characters: {cell[:60]}..."))
    return faults


def check_the_checks() -> None:
    """Text at each limit passes, and text just above it does not."""
    lines, words, cell = "line\n" * MOST_LINES, "word " * MOST_WORDS, "c" * MOST_CHARACTERS
    at_limits = [lines, words, f"| {cell} |"]
    above = [lines + "line", words + "word", f"| {cell}c |"]
    for text in at_limits:
        assert not faults_of(text), text
        assert not faults_of("- " + text.replace("\n", "\n  ").strip() + "\n- next"), text
    for text in above:
        assert len(faults_of(text)) == 1, text
        assert not faults_of("```\n" + text + "\n```"), text


def main() -> int:
    source = pathlib.Path(sys.argv[1])
    check_the_checks()
    pages = [source / "README.md", *sorted((source / "docs").glob("*.md"))]
    assert len(pages) > 20, len(pages)
    wrong = 0
    for page in pages:
        for number, fault in faults_of(page.read_text(encoding="utf-8")):
            print(f"{page.relative_to(source)}:{number}: {fault}")
            wrong += 1
    print(f"{len(pages)} pages, {wrong} faults")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
