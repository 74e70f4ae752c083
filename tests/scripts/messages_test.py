#!/usr/bin/env python3
"""Each message that docs/troubleshooting.md quotes still occurs in the sources.

Usage: messages_test.py SOURCE_DIR

Quotes are the code spans in the first column of its tables. `…` stands for names and numbers: what
is between two of them must be in a string literal, and all of it in one file.
"""

import pathlib
import re
import sys


def quotes_of(page: str) -> list:
    quotes = []
    for row in page.splitlines():
        if not row.startswith("| ") or row.startswith("| ---"):
            continue
        first = row.split(" | ")[0][2:]
        # A span may hold code spans of the message itself: it ends before a comma, a blank and the
        # next span, before words, or at the cell's end.
        quotes += re.findall(r"(?:^|, )`(.+?)`(?=$|, `| [a-z])", first)
    return quotes


def literals_of(file: pathlib.Path) -> str:
    text = file.read_text(encoding="utf-8")
    if file.suffix not in (".cpp", ".h"):
        return text
    text = re.sub(r'"\s*\n\s*"', "", text)  # Adjacent literals are one.
    literals = re.findall(r'"((?:[^"\\\n]|\\.)*)"', text)
    return "\n".join(literals).replace('\\"', '"')


def main() -> int:
    source = pathlib.Path(sys.argv[1])
    skipped = {"build", "tests", "docs", "bench"}
    files = [
        file
        for folder in sorted(source.iterdir())
        if folder.is_dir() and folder.name not in skipped and not folder.name.startswith(".")
        for file in sorted(folder.rglob("*"))
        if file.suffix in (".cpp", ".h") or file.parent == source / "scripts"
    ]
    texts = [literals_of(file) for file in files if file.is_file()]
    quotes = quotes_of((source / "docs/troubleshooting.md").read_text(encoding="utf-8"))
    assert len(quotes) > 100, len(quotes)
    wrong = 0
    for quote in quotes:
        parts = [part.strip() for part in quote.split("…")]
        if max(len(part) for part in parts) < 9:
            print(f"too short to be found: {quote}")
            wrong += 1
        elif not any(all(part in text for part in parts) for text in texts):
            print(f"not in the sources: {quote}")
            wrong += 1
    print(f"{len(quotes)} quotes, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
