"""What is computed of samples: bins, measures, spectra."""
