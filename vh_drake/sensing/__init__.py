"""From clouds and wrenches to objects and contacts."""
