"""What happens in a trial: contacts, excursions, visits and attempts, cut as frames come in."""
