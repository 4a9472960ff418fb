"""What goes to others as it happens: trajectory XML, JSON, ONVIF metadata; HTTP, sockets, MQTT."""
