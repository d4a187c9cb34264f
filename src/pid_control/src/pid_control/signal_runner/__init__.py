"""Runner of the first coursework: both nodes of a student on a private master."""
