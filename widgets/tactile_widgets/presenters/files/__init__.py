"""Files: what is opened and saved, the map being edited and its file, exports of pictures and tables."""
