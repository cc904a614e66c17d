"""What an engineer does while teaching a place (paper 4), without a page, a file or a robot."""
