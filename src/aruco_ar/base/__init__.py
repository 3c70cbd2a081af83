"""What every room uses: types of arrays, errors, files, versions."""
