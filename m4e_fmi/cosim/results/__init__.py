"""The results of a coupled run: blocks of rows in memory, and the writer to disk."""
