"""The page that an FMU carries about itself: HTML with a picture and equations."""
