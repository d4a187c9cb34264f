"""Messages: definitions, fields, decoding and stamps."""
