from .export import FORMATS, ExportFormat, export_recording

__all__ = ["FORMATS", "ExportFormat", "export_recording"]
