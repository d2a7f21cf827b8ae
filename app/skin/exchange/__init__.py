"""Foreign skin files, one format a file: ``icub`` reads positions, ``icub_skin`` puts them on a link."""
