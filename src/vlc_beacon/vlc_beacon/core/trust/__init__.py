"""Which commands are obeyed: authentic, new, spoken by the right lamp at the right place, and harmless."""
