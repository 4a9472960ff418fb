"""A person with a mouse before the calibration page."""

IMAGE, PLAN = 0, 1
PATIENCE_MS = 90_000  # on a busy machine
ON_SCREEN = """([board, x, y]) => {
  const svg = document.querySelectorAll('.board svg')[board];
  const place = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
  return [place.x, place.y];
}"""


class Desk:
    """
    Points at `ground`, metres by name, are seen at `image`, pixels by name.

    `clicks` counts what the person did.
    """

    def __init__(self, page, ground, image):
        self.page, self.ground, self.image = page, ground, image
        self.clicks = 0

    def at(self, board, x, y):
        return self.page.evaluate(ON_SCREEN, [board, x, y])

    def click(self, board, x, y):
        self.page.mouse.click(*self.at(board, x, y))
        self.clicks += 1

    def choose(self, name):
        x, y = self.ground[name]
        self.click(PLAN, x, -y)

    def pair(self, name):
        self.choose(name)
        self.page.wait_for_selector('.image svg.placing')
        self.click(IMAGE, *self.image[name])
        self.is_paired(name)

    def is_paired(self, name):
        self.page.wait_for_selector(f'.image .mark.paired[data-name="{name}"]')

    def save(self, path):
        self.page.get_by_role('button', name='Save').click()
        self.clicks += 1
        self.says(f'Saved {path}')

    def drag(self, start, *, right, down):
        x, y = start
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + right / 2, y + down / 2)
        self.page.mouse.move(x + right, y + down)
        self.page.mouse.up()

    def says(self, text):
        self.page.get_by_text(text).first.wait_for()
