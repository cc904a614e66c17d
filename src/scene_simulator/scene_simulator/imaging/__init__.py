"""What all cameras share."""
