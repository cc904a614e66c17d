"""What the pages in the browser share: access control and the server's main loop."""
