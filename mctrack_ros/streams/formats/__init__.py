"""In which forms a stream is told: trajectory XML, JSON, ONVIF metadata."""
