#!/usr/bin/env python3
"""Links of the built book: each leads to a page or file of the book, and to a place in it that exists.

`book_links.py FOLDER`. Links to other sites are counted, not followed. Exits with 1 where one is dead.
"""
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Places and links of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.links: list[tuple[int, str]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        of = dict(attrs)
        self.places.update(of[key] for key in ("id", "name") if of.get(key))
        for key in ("href", "src"):
            if of.get(key):
                self.links.append((self.getpos()[0], of[key]))


def main(book: Path) -> int:
    pages = {}
    for path in sorted(book.rglob("*.html")):
        pages[path.resolve()] = page = Page()
        page.feed(path.read_text(encoding="utf-8"))
    followed, outside, dead = 0, 0, []
    for path, page in pages.items():
        for line, link in page.links:
            # 404.html is shown from any address: it says that its links begin at the book's root.
            parts = urlsplit("." if link == "/" else link)
            if parts.scheme or parts.netloc:
                outside += 1
                continue
            followed += 1
            to = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            # Folders of sources are links as well: the book stands beside them.
            inside = to.is_relative_to(book.resolve())
            to = to / "index.html" if to.is_dir() and inside else to
            place = unquote(parts.fragment)
            known = to not in pages or not place or place in pages[to].places
            if not to.exists() or not known:
                dead.append(f"{path.relative_to(book.resolve())}:{line}: {link}")
    print(f"book: {len(pages)} pages, {followed} links followed, {outside} lead outside, {len(dead)} dead")
    print("\n".join(dead))
    # A book of nothing has no dead link.
    return 1 if dead or len(pages) < 2 or followed < 100 else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
