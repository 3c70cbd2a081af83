"""The page's server, and a browser that shows the page."""
