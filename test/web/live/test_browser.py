"""A window that is slow is sent less, not later."""

import asyncio

from mctrack_ros.web.live.browser import MOST_IN_FLIGHT, Browser


class Socket:
    """Keeps what is sent."""

    def __init__(self):
        self.sent = []

    async def send_bytes(self, message):
        self.sent.append(message)

    async def send_text(self, text):
        self.sent.append(text)


def test_frames_are_left_out_until_those_before_are_taken():
    async def play():
        socket = Socket()
        browser = Browser(socket)
        browser.cameras = frozenset(['cam1'])
        sending = asyncio.create_task(browser.send())
        for number in range(10):
            browser.offer(b'frame %d' % number)
            browser.offer_image('cam1', b'image %d' % number)
            await asyncio.sleep(0)
            await asyncio.sleep(0)
        browser.tell({'kind': 'events'})
        await asyncio.sleep(0.01)
        before = list(socket.sent)
        browser.taken()
        await asyncio.sleep(0.01)
        browser.taken()
        await asyncio.sleep(0.01)
        sending.cancel()
        return before, socket.sent

    before, sent = asyncio.run(play())
    assert len([each for each in before if isinstance(each, bytes)]) == MOST_IN_FLIGHT
    assert before[-1] == '{"kind": "events"}'
    assert sent[len(before) :] == [b'frame 9', b'image 9']
