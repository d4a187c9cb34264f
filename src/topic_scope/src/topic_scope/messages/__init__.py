"""What messages are: their definitions, fields, values and stamps."""
