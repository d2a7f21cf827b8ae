"""Commands that read an existing recording: replay, export to other formats, recover and trim."""
