"""Skins from foreign files, one format a file: ``icub`` (its lines are taken apart by ``text_rows``)."""
