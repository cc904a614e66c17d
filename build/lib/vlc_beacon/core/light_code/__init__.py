"""Light codes: waveforms and decoders for global and rolling shutters."""
