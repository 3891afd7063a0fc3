"""Problems of a system that are found before anything is built: drafts of components, checked."""
