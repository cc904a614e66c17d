"""What node and ``locate`` share: settings, the localizer of a map file, report and pictures of a result."""
