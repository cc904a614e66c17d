"""Local features of the whole taught view: they find the place, veto wrong fits and contribute points."""
