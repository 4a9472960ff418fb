"""Whether a page is well formed."""

from html.parser import HTMLParser

VOID = {'meta', 'input', 'img', 'br', 'link', 'hr'}


class Balanced(HTMLParser):
    """Notes whether every element that opens also closes, and what addresses are named."""

    def __init__(self):
        super().__init__()
        self.open, self.addresses, self.images = [], [], 0

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in ('src', 'href')]
        self.images += tag == 'img'
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in ('src', 'href')]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
