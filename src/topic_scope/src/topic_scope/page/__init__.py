"""What one page is shown of the samples."""
