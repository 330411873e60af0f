"""What shuts a worker in, a layer in each module; each says what it did."""
