"""Topics: message classes, quality of service, and what is made for other tools."""
