"""The page that an FMU carries about itself: HTML with MathML and a picture."""
