"""Named zones and lines of a site, and the events of tracks at them."""
