"""The nodes' parameters: what each may be, all of them, and changing them at run time."""
