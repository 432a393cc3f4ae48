"""The embedded object library and loaders for folders of objects."""
