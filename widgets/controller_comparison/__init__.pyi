from .comparison_view import ComparisonView

__all__ = [
    "ComparisonView",
]
