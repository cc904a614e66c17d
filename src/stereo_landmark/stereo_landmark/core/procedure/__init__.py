"""From primitives in two images to taught targets: the procedure tree, its windows and its verdict."""
