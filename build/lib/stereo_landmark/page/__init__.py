"""The teaching page: a small web server on the robot or beside it, and one page in a browser."""
