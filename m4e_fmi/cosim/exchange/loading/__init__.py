"""FMUs unpacked and loaded: folders, copies of libraries, and libraries that may be shared."""
