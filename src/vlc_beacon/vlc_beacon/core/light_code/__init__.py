"""How lamps blink: waveforms and their decoders, for global and for rolling shutters."""
